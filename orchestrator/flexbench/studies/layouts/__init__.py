"""Comparison of the layouts of the wheels: does distributing them pay?"""

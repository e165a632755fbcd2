"""Spillover: what a controller does to the modes that its model leaves out."""

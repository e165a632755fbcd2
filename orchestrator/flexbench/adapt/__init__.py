"""Adapters for attitude controllers: contract, excitation and verdict."""

"""Adapt foreign attitude controllers: contracts, drafts of adapters, and tests of their conventions."""

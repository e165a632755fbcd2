"""Rare events of campaigns: by chains over the inputs, or by branches along time."""

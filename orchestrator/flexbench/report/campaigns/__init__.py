"""The page of a campaign: distributions, requirements, worst runs, scatter matrix, bands; it needs no network."""

from .write import write_campaign_page

__all__ = ["write_campaign_page"]

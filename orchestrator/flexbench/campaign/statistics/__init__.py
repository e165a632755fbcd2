"""Statistics of campaigns: numbers with confidence bounds that assume no distribution."""

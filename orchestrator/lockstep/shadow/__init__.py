"""A second controller that rides along open loop beside the first, and can take over from it without a jump."""

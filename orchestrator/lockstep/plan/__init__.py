"""What a run will do, worked out before it starts: schedule, wiring and bus layout."""

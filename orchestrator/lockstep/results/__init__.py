"""Results folders: recording, run record and reading."""

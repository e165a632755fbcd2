"""Run FMUs in processes of their own: whatever one does to its process, the run ends with one line and results."""

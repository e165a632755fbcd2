"""FMUs in processes of their own: what one of them does to its process ends the run in one line, and nothing else."""

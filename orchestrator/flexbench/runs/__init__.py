"""Results of runs: folders, histories, metrics and exports."""

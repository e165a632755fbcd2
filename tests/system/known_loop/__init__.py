"""Two small FMUs in C whose loop is known in closed form."""

"""The flight controller alone as C99, for flight software: without FMI, host or file system."""

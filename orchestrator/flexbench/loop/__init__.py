"""The closed loop of the spacecraft: scenarios, system files, builds and their equivalence."""

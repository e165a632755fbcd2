"""One spacecraft: structure, devices and wheel speeds as a linear model."""

"""Run-time steppers of plant, sensors and controller. They import numpy alone: they travel in the FMUs."""

"""Steppers of missions: environment, thrusters, and the manager of modes. numpy alone."""

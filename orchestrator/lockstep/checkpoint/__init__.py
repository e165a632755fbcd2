"""The state of a whole run at one time: saved while it goes on, resumed after a kill, branched into other runs."""

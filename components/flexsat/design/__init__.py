"""Controller design: regulator, estimator, slew programme, and the chain from parameters to matrices."""

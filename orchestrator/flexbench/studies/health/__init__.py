"""Consistency of the estimator with its own covariance: NIS and NEES with bounds, whiteness of the innovations."""

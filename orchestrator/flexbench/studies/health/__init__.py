"""Health of the estimator: is it as good as it believes? Innovations, their whiteness, NIS and NEES with bounds."""

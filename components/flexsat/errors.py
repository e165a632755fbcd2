"""What a user can mend when a build fails; every other error of the package is a wrong argument, or a bug."""


class BuildError(ValueError):
    """This machine lacks what building the FMUs needs, in one line with the remedy."""

"""What a user can mend: a build that fails, a spacecraft's file; every other error is a wrong argument, or a bug."""


class BuildError(ValueError):
    """This machine lacks what building the FMUs needs, in one line with the remedy."""


class SpacecraftFileError(ValueError):
    """A spacecraft's file is refused, in one line with file, line, key, wrong value and remedy."""

"""What the command line refuses."""


class UsageError(ValueError):
    """The command line asks for something that is not there or does not go together."""

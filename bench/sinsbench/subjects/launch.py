"""Become another program, under limits of memory and of file size: ``launch.py MEMORY SIZE PROGRAM ARGUMENT...``.

A script of its own, run with any Python: limits set between fork and exec by the process that has threads may hang it.
"""

import contextlib
import os
import signal
import sys

CANNOT_RUN = 126
"""Exit status where there is nothing to become, as that of a shell."""


def _limit(kind: int, most: int) -> None:
    import resource

    hard = resource.getrlimit(kind)[1]
    least = most if hard == resource.RLIM_INFINITY else min(most, hard)
    with contextlib.suppress(OSError, ValueError):  # a system that does not limit this refuses
        resource.setrlimit(kind, (least, least))


def main(memory: int, size: int, command: list[str]) -> None:
    """Set the limits, and become the command.

    Parameters
    ----------
    memory : int
        Most bytes of memory of each process.
    size : int
        Most bytes of each file.
    command : list of str
    """
    import resource

    # What counts are private pages that can be written, where the system counts them (Linux): address space that is
    # only reserved, as by the engines of JavaScript, Java and Go, is no memory.
    _limit(resource.RLIMIT_DATA if sys.platform == "linux" else resource.RLIMIT_AS, memory)
    _limit(resource.RLIMIT_FSIZE, size)
    _limit(resource.RLIMIT_CORE, 0)
    for name in (signal.SIGPIPE, signal.SIGXFSZ):  # Python ignores these, and what it becomes would too
        signal.signal(name, signal.SIG_DFL)
    try:
        os.execvp(command[0], command)
    except OSError as error:
        print(f"cannot run {command[0]}: {error.strerror}", file=sys.stderr)
        sys.exit(CANNOT_RUN)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])

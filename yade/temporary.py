"""YADE's own folder in the temporary one. Nothing of it is used here, and it would stay where the process is killed."""

import contextlib
from pathlib import Path

from yade.wrapper import Omega


def remove_own_folder() -> None:
    """Remove the folder if it is empty."""
    with contextlib.suppress(OSError):
        Path(Omega().tmpFilename()).parent.rmdir()

"""Locks in processes that fork."""

import os
import threading


class ProcessLock:
    """A lock that a forked process has anew: there, the thread that held it does not exist."""

    def __init__(self) -> None:
        self._locks: dict[int, threading.Lock] = {}

    def __enter__(self) -> None:
        self._locks.setdefault(os.getpid(), threading.Lock()).acquire()

    def __exit__(self, *_: object) -> None:
        self._locks[os.getpid()].release()

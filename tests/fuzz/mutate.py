"""Fuzz one reader for some time: by coverage with atheris where it is installed, else at random.

    python tests/fuzz/mutate.py obj 600          # ten minutes
    python tests/fuzz/mutate.py --random dxf 60 --seed 3

Ends with the number of runs and the slowest of them, or with the input of a finding (exit code 1):
a traceback from inside, or a run of more than LIMIT seconds. Atheris has wheels for Python 3.12.
"""

from __future__ import annotations

import argparse
import importlib.util
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

from readers import READERS, TOKENS, Reader

LIMIT = 30  # seconds for one small file
LARGEST = 1 << 19  # bytes
NUMBER = re.compile(rb"#?[-+]?\d[\d.]*(?:[eEdD][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_]{3,}")
LINE = re.compile(rb"[^\n]*\n")
NUMBERS = (b"0", b"1", b"-1", b"1E300", b"1E-300", b"1E5", b"2147483647", b"99999999999", b"$")


def mutated(seeds: list[bytes], rng: random.Random) -> bytes:
    """A seed with some bytes, lines or tokens changed, taken out, doubled or swapped."""
    data = bytearray(rng.choice(seeds))
    if rng.random() < 0.5:
        return _reworded(bytes(data), rng)
    for _ in range(rng.choice((1, 1, 2, 3, 8))):
        size = len(data)
        at = rng.randrange(size + 1)
        end = min(size, at + rng.choice((0, 1, 1, 2, 4, 16, 200)))
        how = rng.randrange(6)
        if how == 0:
            data[at:end] = rng.randbytes(rng.choice((1, 2, 4)))
        elif how == 1:
            data[at:end] = rng.choice(TOKENS)
        elif how == 2:
            del data[at:end]
        elif how == 3:
            data[at:at] = data[at:end] * rng.choice((1, 2, 50))
        elif how == 4:
            other = rng.choice(seeds)
            cut = rng.randrange(len(other) + 1)
            data[at:end] = other[cut : cut + 40]
        elif size:
            data[at % size] ^= 1 << rng.randrange(8)
    return bytes(data[:LARGEST])


def _reworded(data: bytes, rng: random.Random) -> bytes:
    """The same text with numbers, references (#12) and words changed, or lines left out."""
    for _ in range(rng.choice((1, 1, 2, 3, 8))):
        kind = rng.choice((NUMBER, NUMBER, NUMBER, WORD, LINE))
        found = list(kind.finditer(data))
        if not found:
            continue
        place = rng.choice(found)
        old = place.group()
        new = rng.choice(found).group()  # one of its kind
        if kind is LINE and rng.random() < 0.5:
            new = b""
        elif kind is NUMBER and rng.random() < 0.6:
            sign = old[: old.startswith(b"#")]
            new = sign + rng.choice(
                (*NUMBERS, b"%d" % rng.randrange(1000), b"-" + old[len(sign) :])
            )
        data = data[: place.start()] + new + data[place.end() :]
    return data[:LARGEST]


def by_chance(reader: Reader, seconds: float, seed: int) -> tuple[int, float]:
    """Mutate at random; the number of runs and the slowest run."""
    rng, seeds = random.Random(seed), reader.seeds()
    runs, slowest = 0, 0.0
    signal.signal(signal.SIGALRM, _too_slow)
    reader(seeds[0])
    end = time.monotonic() + seconds  # what readers import takes its own time
    while time.monotonic() < end:
        data = mutated(seeds, rng)
        begin = time.monotonic()
        signal.alarm(LIMIT)
        try:
            reader(data)
        except BaseException:
            _report(data)
            raise
        finally:
            signal.alarm(0)
        runs, slowest = runs + 1, max(slowest, time.monotonic() - begin)
    return runs, slowest


def by_coverage(reader: Reader, seconds: float, seed: int) -> None:
    """Let atheris look for inputs that reach new code."""
    import atheris

    with tempfile.TemporaryDirectory() as corpus:
        for number, data in enumerate(reader.seeds()):
            Path(corpus, f"seed-{number}").write_bytes(data)
            reader(data)  # loads what it reads with: that is followed, too
        atheris.instrument_all()
        flags = [f"-max_total_time={seconds:.0f}", f"-timeout={LIMIT}", f"-seed={seed + 1}"]
        flags += [f"-max_len={LARGEST}", "-rss_limit_mb=4096", "-artifact_prefix=finding-"]
        atheris.Setup([sys.argv[0], corpus, *flags], reader)
        atheris.Fuzz()


def _too_slow(*_: object) -> None:
    raise TimeoutError(f"a file took more than {LIMIT} s")


def _report(data: bytes) -> None:
    path = Path(tempfile.gettempdir()) / f"finding-{abs(hash(data)):x}"
    path.write_bytes(data)
    traceback.print_exc()
    print(f"finding: {len(data)} bytes kept in {path}: {data[:200]!r}")


def main() -> None:
    """Fuzz the reader named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("reader", choices=READERS)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--random", action="store_true", help="without atheris")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    reader = READERS[asked.reader]
    if asked.random or importlib.util.find_spec("atheris") is None:
        runs, slowest = by_chance(reader, asked.seconds, asked.seed)
        print(f"{asked.reader}: {runs} files, no finding; slowest {slowest:.2f} s")
    else:
        by_coverage(reader, asked.seconds, asked.seed)


if __name__ == "__main__":
    main()

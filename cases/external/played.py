"""What the scripts that play a solver (su2/fake_su2.py, cart3d/fake_cart3d.py) share: files that stand for meshes and
solutions hold nothing but a mark of what they were made for, so that one of another design is noticed.

Not for cases of your own: they need no fake. The scripts look for this file, newton.py and volume.py one folder up."""
import hashlib
import sys


def stop(message):
    print(f"ERROR: {message}", file=sys.stderr)
    sys.exit(1)


def mark_of(name):
    """Of a file, by its content."""
    with open(name, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def save(name, mark):
    with open(name, "w", encoding="ascii") as file:
        file.write(mark)


def need(name, mark, other):
    """Stops unless the file holds this mark; other: what it is "of" then."""
    try:
        with open(name, encoding="ascii") as file:
            if file.read() != mark:
                stop(f"{name} is of {other}")
    except OSError as error:
        stop(f"{name}: {error.strerror}")

#!/usr/bin/env python3
"""An evaluation by Cart3D, values only: cart3d.py PROGRAMS REQUEST RESULT, in the current folder.

PROGRAMS is the folder of Cart3D's programs; or a script that plays them and gets their name as first argument, such as
fake_cart3d.py. Strake has written the surface with its components (`format: tri`).

    autoInputs   Components.i.tri -> input.c3d, preSpec.c3d.cntl
    cubes        -> Mesh.R.c3d
    mgPrep       -> Mesh.mg.c3d
    flowCart     with input.cntl and Config.xml -> loadsCC.dat: forces on all and on each component
"""
import json
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
STEPS = [["autoInputs", "-r", "10", "-t", "Components.i.tri"],
         ["cubes", "-pre", "preSpec.c3d.cntl", "-maxR", "10", "-reorder", "-a", "10", "-b", "2"],
         ["mgPrep", "-n", "3"],
         ["flowCart", "-T", "-his", "-clic", "-mg", "3", "-N", "200"]]
WANTED = {"drag": ("entire", "C_D"), "lift": ("entire", "C_L"), "nose_drag": ("nose", "C_D")}


def run(programs, program, *options):
    command = [os.path.join(programs, program)] if os.path.isdir(programs) else [programs, program]
    done = subprocess.run([*command, *options], check=False)
    if done.returncode != 0:
        sys.exit(f"cart3d.py: {program} ended with status {done.returncode}")


def loads(name):
    """{(component, coefficient): value} of loadsCC.dat, lines such as `wing  Drag Force (C_D): 0.0123`."""
    values = {}
    with open(name, encoding="ascii") as file:
        for line in file:
            words = line.split()
            if words and not line.startswith("#"):
                values[words[0], words[-2].strip("():")] = float(words[-1])
    return values


def main(programs, request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    os.replace(request["surface"], "Components.i.tri")
    for name in ("input.cntl", "Config.xml"):
        shutil.copyfile(os.path.join(HERE, name), name)
    for step in STEPS:
        run(programs, *step)
    found = loads("loadsCC.dat")
    with open(result_file, "w", encoding="ascii") as file:
        json.dump({"values": {name: found[key] for name, key in WANTED.items()}}, file)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])

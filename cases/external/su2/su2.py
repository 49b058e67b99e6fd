#!/usr/bin/env python3
"""An evaluation by SU2: su2.py PROGRAMS REQUEST RESULT, in the current folder.

PROGRAMS is the folder that holds SU2_DEF, SU2_CFD, SU2_CFD_AD and SU2_DOT_AD; or a script that plays them and gets their
name as first argument, such as fake_su2.py. Strake has written surface_positions.dat (`format: su2-positions`).

    SU2_DEF     mesh.su2 and surface_positions.dat -> mesh_out.su2
    SU2_CFD     mesh_out.su2 -> history.csv (CD, CL) and restart_flow.dat
    SU2_CFD_AD  for each gradient that is wanted: restart_flow.dat -> restart_adj_cd.dat
    SU2_DOT_AD  back through the mesh deformation -> surface_sens.csv, which is what Strake reads
"""
import csv
import json
import os
import re
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
COLUMNS = {"drag": "CD", "lift": "CL"}
OBJECTIVES = {"drag": ("DRAG", "cd"), "lift": ("LIFT", "cl")}  # and what SU2 appends to names of adjoint files


def configure(name, **changed):
    """flow.cfg with some of its keys changed; a key twice, or one that is not there, SU2 would refuse."""
    with open(os.path.join(HERE, "flow.cfg"), encoding="ascii") as file:
        text = file.read()
    for key, value in changed.items():
        text, count = re.subn(rf"^{key}=.*$", f"{key}= {value}", text, flags=re.MULTILINE)
        if count != 1:
            sys.exit(f"su2.py: {key} stands {count} times in flow.cfg")
    with open(name, "w", encoding="ascii") as file:
        file.write(text)


def run(programs, program, config):
    command = [os.path.join(programs, program)] if os.path.isdir(programs) else [programs, program]
    done = subprocess.run([*command, config], check=False)
    if done.returncode != 0:
        sys.exit(f"su2.py: {program} ended with status {done.returncode}")


def last_row(name):
    """The last line of a history file by its columns, whose names SU2 puts in quotes and pads."""
    with open(name, encoding="ascii") as file:
        rows = [[word.strip().strip('"').strip() for word in row] for row in csv.reader(file)]
    return dict(zip(rows[0], map(float, rows[-1])))


def gradient(programs, name, mesh):
    """The adjoint of one value; returns the file of its sensitivities."""
    objective, suffix = OBJECTIVES[name]
    adjoint = {"MATH_PROBLEM": "DISCRETE_ADJOINT", "OBJECTIVE_FUNCTION": objective, "MESH_FILENAME": mesh,
               "CONV_FILENAME": "history_" + name, "SURFACE_SENS_FILENAME": "sens_" + name}
    configure(f"adjoint_{name}.cfg", **adjoint)
    run(programs, "SU2_CFD_AD", f"adjoint_{name}.cfg")
    shutil.copyfile(f"restart_adj_{suffix}.dat", f"solution_adj_{suffix}.dat")
    run(programs, "SU2_DOT_AD", f"adjoint_{name}.cfg")
    return f"sens_{name}.csv"


def main(programs, request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    mesh = os.path.join(HERE, "generated/mesh.su2")
    configure("deform.cfg", MESH_FILENAME=mesh, DV_FILENAME=request["surface"])
    run(programs, "SU2_DEF", "deform.cfg")
    configure("flow.cfg", MESH_FILENAME="mesh_out.su2")
    run(programs, "SU2_CFD", "flow.cfg")
    row = last_row("history.csv")
    result = {"values": {name: row[column] for name, column in COLUMNS.items()}, "gradients": {}}
    wanted = request["wanted"]["gradients"]
    if wanted:
        shutil.copyfile("restart_flow.dat", "solution_flow.dat")
    for name in wanted:
        result["gradients"][name] = gradient(programs, name, "mesh_out.su2")
    with open(result_file, "w", encoding="ascii") as file:
        json.dump(result, file)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])

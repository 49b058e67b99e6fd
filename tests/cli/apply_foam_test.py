"""`strake apply` on a mesh that snappyHexMesh makes about a body, judged by checkMesh: apply_foam_test.py STRAKE
MAKE_SURFACE EXAMPLES. The body is bent by 5 % of its diagonal; no cell turns inside out, and the mesh is as good as before.
Ends with 77, which ctest counts as skipped, where OpenFOAM is not installed (the cells themselves are also checked without
it, in apply_program_test)."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

if not all(map(shutil.which, ("blockMesh", "snappyHexMesh", "checkMesh"))):
    print("skipped: snappyHexMesh and checkMesh are not installed (scripts/setup.sh openfoam)")
    sys.exit(77)
STRAKE, MAKE_SURFACE, EXAMPLES = sys.argv[1:4]
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(EXAMPLES, "openfoam"))
import flow
import foam

CASE = """case: bent
surface: {file: body.obj}
regions: {nose: {box: [[-9, -9, -9], [-0.3, 9, 9]]}, tail: {box: [[0.3, -9, -9], [9, 9, 9]]}}
fixed: [nose]
loads: [{region: tail, displacement: 5%, direction: [0, 0.5, 1]}]
"""


def told(*command):
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 0, (command, done.returncode, done.stderr)
    return json.loads(done.stdout) if "--json" in command else None


def measured(folder):
    text = foam.run(folder, "checkMesh", "-constant")

    def number(pattern):
        return float(re.search(pattern + r"\s*=?\s*([-+0-9.e]+)", text)[1].rstrip("."))

    return {"ok": "Mesh OK" in text, "skewness": number("Max skewness"), "volume": number("Min volume"),
            "non_orthogonality": number("non-orthogonality Max:"), "aspect": number("Max aspect ratio")}


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        told(MAKE_SURFACE, "bluff_body", "--triangles", "2000", "-o", "body.obj")
        with open("case.yaml", "w", encoding="ascii") as file:
            file.write(CASE)
        bent = told(STRAKE, "deform", "case.yaml", "-o", "bent.obj", "--json")
        diagonal = told(STRAKE, "info", "body.obj", "--json")["diagonal"]
        assert bent["max_displacement"] > 0.045 * diagonal, bent
        cells = flow.build(os.path.join(EXAMPLES, "openfoam_drag/foam"), "flow", foam.read_obj("body.obj"),
                           {"cellsAlong": 12, "cellsAcross": 9})
        before = measured("flow")
        shutil.copytree("flow/system", "moved/system")
        os.makedirs("moved/constant")
        applied = told(STRAKE, "apply", "body.obj", "flow", "--moved", "bent.obj", "-o", "moved/constant/polyMesh", "--json")
        assert applied["cells"]["checked"] == cells and applied["cells"]["newly_bad"] == 0, applied
        after = measured("moved")
        os.chdir("/")
    print(f"{cells} cells, moved by {bent['max_displacement'] / diagonal:.3f} diagonals\nbefore {before}\nafter  {after}")
    assert before["ok"] and after["ok"], "checkMesh is not content"
    assert after["volume"] > 0.5 * before["volume"] > 0
    assert after["non_orthogonality"] < before["non_orthogonality"] + 5
    assert after["skewness"] < 1.3 * before["skewness"] + 0.2


if __name__ == "__main__":
    main()

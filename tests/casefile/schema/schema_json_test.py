"""The JSON Schema of `strake schema --json`: valid itself, valid for every shipped case and for what the loader accepts,
and it finds what an editor should underline. Arguments: the program, the folder of the cases, a folder for the output.

Needs python3-jsonschema and python3-yaml; without them it is skipped (77)."""
import json
import pathlib
import re
import subprocess
import sys

try:
    import jsonschema
    import yaml
except ImportError as missing:
    print("skipped:", missing)
    sys.exit(77)

STRAKE, CASES = sys.argv[1], pathlib.Path(sys.argv[2])


class Loader(yaml.SafeLoader):
    """YAML 1.2 as editors and Strake read it: 1e-6 is a number, yes and y are text."""


Loader.yaml_implicit_resolvers = {}
for tag, expression, first in (
        ("bool", r"^(?:true|false)$", "tf"), ("null", r"^(?:~|null|)$", ["~", "n", ""]),
        ("int", r"^[-+]?[0-9]+$", "-+0123456789"),
        ("float", r"^[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?$", "-+0123456789.")):
    Loader.add_implicit_resolver("tag:yaml.org,2002:" + tag, re.compile(expression), list(first))

GOOD = """
case: wing
surface: {file: wing.obj, units: mm}
repair: {orient: true, holes: all, weld: 1e-6%}
regions: {root: {box: [[-1, -1, 0 mm], [1, 0.01, 1]]}, tip: {plane: {normal: [0, 1, 0], at: 1e-1}, side: above}}
fixed: [root]
symmetry: {plane: y}
shell: {thickness: {default: 2%, root: 4 mm}}
loads: [{region: tip, displacement: 5%, direction: [0, 0, 1]}]
parameters: {levels: [20deg, 10deg], min_patch: 1%, variables: [load], max_displacement: 5%}
variables: {alpha: {start: 3deg, min: 0deg, max: 6deg}}
quantities:
  match: {type: target_shape, file: t.obj, match: same}
  aero: {command: [./run.sh], outputs: [drag], timeout: 2h, on_failure: shrink_step}
objective: {minimize: aero.drag}
constraints: {volume: {min: 1.0, relative: true}}
optimize: {method: NLOPT_LD_SLSQP, budget: {evaluations: 200, time: 3h}}
"""
# (old, new, path of what is wrong)
BROKEN = [
    ("objective:", "objektive:", ""),
    ("surface: {file: wing.obj, units: mm}", "surface: {units: mm}", "surface"),
    ("units: mm", "units: furlong", "surface/units"),
    ("orient: true", "orient: yes please", "repair/orient"),
    ("evaluations: 200", "evaluations: 0", "optimize/budget/evaluations"),
    ("evaluations: 200", "evaluations: 2.5", "optimize/budget/evaluations"),
    ("time: 3h", "time: 3", "optimize/budget/time"),
    ("time: 3h", "time: 3 weeks", "optimize/budget/time"),
    ("NLOPT_LD_SLSQP", "slqsp", "optimize/method"),
    ("[20deg, 10deg]", "[20, 10]", "parameters/levels"),
    ("max_displacement: 5%", "max_displacement: 5 miles", "parameters/max_displacement"),
    ("variables: [load]", "variables: [laod]", "parameters/variables/0"),
    ("[[-1, -1, 0 mm], [1, 0.01, 1]]", "[[-1, -1, 0 mm]]", "regions/root/box"),
    ("[[-1, -1, 0 mm], [1, 0.01, 1]]", "[[-1, -1, 5%], [1, 0.01, 1]]", "regions/root/box/0/2"),
    ("side: above", "side: abvoe", "regions/tip/side"),
    (", side: above", "", "regions/tip"),
    ("fixed: [root]", "fixed: root", "fixed"),
    (", direction: [0, 0, 1]", "", "loads/0"),
    ("file: t.obj, ", "", "quantities/match"),
    ("on_failure: shrink_step", "on_failure: hope", "quantities/aero/on_failure"),
    ("type: target_shape, file: t.obj, match: same", "type: volume, match: same", "quantities/match/type"),
    ("levels: [20deg, 10deg], ", "", "parameters"),  # min_patch goes with a list of levels
    ("relative: true", "relativ: true", "constraints/volume"),
    ("start: 3deg", "start: north", "variables/alpha/start"),
]


def read(text):
    return yaml.load(text, Loader)


def places_of(errors):
    """Of errors, and of what is wrong with each of the forms that a value may have."""
    for error in errors:
        yield "/".join(map(str, error.absolute_path))
        yield from places_of(error.context)


def main():
    schema = json.loads(subprocess.run([STRAKE, "schema", "--json"], check=True, stdout=subprocess.PIPE).stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    failures = []
    shipped = [f for f in sorted(CASES.rglob("*.yaml")) if re.search(r"^case *:", f.read_text(), re.M)]
    if len(shipped) < 8:
        failures.append("only %d cases found" % len(shipped))
    for file in shipped:
        failures += ["%s: %s: %s" % (file, "/".join(map(str, e.absolute_path)), e.message)
                     for e in validator.iter_errors(read(file.read_text()))]
    failures += ["the good case: %s: %s" % ("/".join(map(str, e.absolute_path)), e.message)
                 for e in validator.iter_errors(read(GOOD))]
    for old, new, place in BROKEN:
        assert old in GOOD, old
        places = list(places_of(validator.iter_errors(read(GOOD.replace(old, new)))))
        if place not in places:
            failures.append("%r for %r is not found at %r but at %r" % (new, old, place, places))
    # What an editor shows while one types.
    method = schema["properties"]["optimize"]["properties"]["method"]
    if "sqp" not in method["anyOf"][0].get("enum") or not method["description"] or method["default"] != "auto":
        failures.append("optimize.method offers nothing: %r" % method)
    print("\n".join(failures) or "%d cases valid, %d mistakes found" % (len(shipped), len(BROKEN)))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

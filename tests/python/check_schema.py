"""check_schema.py SCHEMA FILE...: "sound" or what is wrong, a line for each YAML file."""

import sys

import jsonschema
import yaml

with open(sys.argv[1]) as file:
    schema = yaml.safe_load(file)
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
for name in sys.argv[2:]:
    with open(name) as file:
        error = next(validator.iter_errors(yaml.safe_load(file)), None)
    print("sound" if error is None else f"{error.json_path}: {error.message}")

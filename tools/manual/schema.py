"""A JSON schema (draft 7) of the file that `foreland serve --config` reads, for editors and for checks before a server is restarted."""

import json

TYPES = {"whole": "integer", "number": "number", "number or text": ["number", "string"]}


def key_of(option):
    return option["names"][-1].lstrip("-")


def default_of(option):
    text = option["default"]
    if option["type"] == "text" or option["type"] in ("file", "folder"):
        return text
    try:
        return json.loads(text)
    except ValueError:
        return text


def value_of(option):
    """What a value may be. An empty text is as if the option were not given."""
    value = {"type": TYPES.get(option["type"], "string")}
    for key, name in (("least", "minimum"), ("most", "maximum"), ("above", "exclusiveMinimum")):
        if key in option:
            value[name] = option[key]
    if "words" in option:
        value["enum"] = [*option["words"], ""]
    if "pattern" in option:
        value["pattern"] = f"^({option['pattern']})?$"
    return value


def property_of(option):
    value = value_of(option)
    if option["repeatable"]:
        value = {"anyOf": [value, {"type": "array", "items": value}]}
    if "default" in option:
        value["default"] = default_of(option)
    return {"description": option["description"], **value}


def schema(serve):
    keys = [o for o in serve.options if o["in_config"]]
    return {"$schema": "http://json-schema.org/draft-07/schema#", "title": "The configuration of foreland serve", "type": "object",
            "properties": {key_of(o): property_of(o) for o in keys}, "additionalProperties": False}


def text(serve):
    return json.dumps(schema(serve), indent=1) + "\n"

"""The description of a dataset in Croissant 1.1: JSON-LD that search engines and data loaders understand.

Croissant has no property for units. It has annotations, fields that say something about a field, and these may be
constant: each column with a unit carries one that is equivalent to ``unitText`` of schema.org.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from sinsdata.format.schema import arrow_schema
from sinsdata.format.storage import json_text

if TYPE_CHECKING:
    import pyarrow as pa

CONFORMS_TO = "http://mlcommons.org/croissant/1.1"
_PARQUET = "application/x-parquet"
_LICENSES = {"CC0-1.0": "https://creativecommons.org/publicdomain/zero/1.0/"}
_TYPES = {"string": "sc:Text", "int64": "cr:Int64", "double": "cr:Float64"}

_OWN_TERMS = (
    "annotation", "arrayShape", "citeAs", "column", "containedIn", "equivalentProperty", "excludes", "extract",
    "field", "fileProperty", "fileObject", "fileSet", "format", "includes", "isArray", "isLiveDataset", "jsonPath",
    "key", "md5", "parentField", "path", "recordSet", "references", "regex", "readLines", "repeated", "replace",
    "samplingRate", "sdVersion", "separator", "source", "subField", "transform", "unArchive",
)  # fmt: skip
#: The context of the specification's appendix 1.
_CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "sc": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "description": {"@container": "@language"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "name": {"@container": "@language"},
    **{term: f"cr:{term}" for term in _OWN_TERMS},
}


def croissant_text(manifest: Mapping[str, Any]) -> str:
    """Return the content of ``croissant.json``: the same text for the same dataset, always.

    Parameters
    ----------
    manifest : mapping
        Of the dataset, with the entries of its tables; the other files need not be there yet.
    """
    return json_text(croissant(manifest))


def croissant(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Return the Croissant description of a dataset.

    Parameters
    ----------
    manifest : mapping
        As for `croissant_text`.

    Returns
    -------
    dict
        JSON-LD: a FileObject with its SHA-256 for each Parquet file, a FileSet for each table of several files, a
        RecordSet for each table, a Field for each column.
    """
    dataset, doi = manifest["dataset"], manifest["doi"]
    tables = manifest["tables"]
    return {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS_TO,
        "name": f"sinsbench_{dataset}_{manifest['tier']}",
        "description": f"{manifest['title']}. Tier {manifest['tier']}; {manifest['certification']['method']}.",
        "version": manifest["version"],
        "license": _LICENSES[manifest["license"]],
        "creator": {"@type": "sc:Organization", "name": "The sinsbench developers"},
        "citeAs": f"{manifest['source']}{f', doi:{doi}' if doi else ''}",
        **({"citation": f"https://doi.org/{doi}"} if doi else {}),
        "isLiveDataset": False,
        "distribution": [node for table, entry in tables.items() for node in _files(table, entry)],
        "recordSet": [_record_set(dataset, table, entry) for table, entry in tables.items()],
    }


def _files(table: str, entry: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for file in entry["files"]:
        yield {
            "@type": "cr:FileObject",
            "@id": file["file"],
            "name": file["file"],
            "contentUrl": file["file"],
            "contentSize": f"{file['bytes']} B",
            "encodingFormat": _PARQUET,
            "sha256": file["sha256"],
        }
    if len(entry["files"]) > 1:
        yield {
            "@type": "cr:FileSet",
            "@id": f"{table}-files",
            "name": f"{table}-files",
            "encodingFormat": _PARQUET,
            "includes": f"{table}-*.parquet",
        }


def _record_set(dataset: str, table: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    schema = arrow_schema(dataset, table)
    single = len(entry["files"]) == 1
    origin = {"fileObject": {"@id": entry["files"][0]["file"]}} if single else {"fileSet": {"@id": f"{table}-files"}}
    keys = [name for name in ("case", "sample", "time") if name in schema.names][:2]
    return {
        "@type": "cr:RecordSet",
        "@id": table,
        "name": table,
        "description": f"{entry['rows']} rows; {len(schema)} columns.",
        "key": [{"@id": f"{table}/{name}"} for name in keys],
        "field": [_field(table, field, origin) for field in schema],
    }


def _field(table: str, field: pa.Field, origin: Mapping[str, Any]) -> dict[str, Any]:
    about = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
    details = [f"{key}: {about[key]}" for key in ("unit", "frame", "accuracy") if key in about]
    name = f"{table}/{field.name}"
    described: dict[str, Any] = {
        "@type": "cr:Field",
        "@id": name,
        "name": field.name,
        "description": "; ".join([about.get("description", field.name), *details]),
        "dataType": _TYPES[str(field.type)],
        "source": {**origin, "extract": {"column": field.name}},
    }
    if "unit" in about:
        described["annotation"] = {
            "@type": "cr:Field",
            "@id": f"{name}/unit",
            "name": "unit",
            "dataType": "sc:Text",
            "equivalentProperty": "sc:unitText",
            "value": about["unit"],
        }
    return described

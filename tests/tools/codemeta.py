"""Write codemeta.json from what CITATION.cff and pyproject.toml say: python tests/tools/codemeta.py"""

import json
import tomllib
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parents[2]
OF_A_PERSON = {"orcid": "@id", "given-names": "givenName", "family-names": "familyName", "email": "email"}
CITED = {"title": "name", "version": "version", "date-released": "datePublished", "repository-code": "codeRepository"}


def author(cited: dict[str, str]) -> dict[str, Any]:
    """Return a person, who has a family name, or an organization in words of CodeMeta."""
    if "family-names" not in cited:
        return {"@type": "Organization", "name": cited["name"]}
    place = {"affiliation": {"@type": "Organization", "name": cited["affiliation"]}} if "affiliation" in cited else {}
    return {"@type": "Person", **{name: cited[key] for key, name in OF_A_PERSON.items() if key in cited}, **place}


def codemeta() -> dict[str, Any]:
    """Return the description of the software in CodeMeta 3.0; what is not known yet is left out."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (chapter,) = cited["references"]
    known = {name: str(cited[key]) for key, name in CITED.items() if key in cited}
    return {
        "@context": "https://w3id.org/codemeta/3.0",
        "@type": "SoftwareSourceCode",
        **({"identifier": f"https://doi.org/{cited['doi']}"} if "doi" in cited else {}),
        **known,
        "description": project["description"],
        "keywords": project["keywords"],
        "license": f"https://spdx.org/licenses/{project['license']}",
        "author": [author(one) for one in cited["authors"]],
        "programmingLanguage": "Python",
        "runtimePlatform": f"Python {project['requires-python']}",
        "operatingSystem": [kind.split(" :: ")[-1] for kind in project["classifiers"] if kind.startswith("Operating")],
        "softwareRequirements": project["dependencies"],
        "referencePublication": {
            "@type": "ScholarlyArticle",
            "@id": f"https://doi.org/{chapter['doi']}",
            "name": f"{chapter['section']}. In: {chapter['title']}",
        },
    }


if __name__ == "__main__":
    text = json.dumps(codemeta(), indent=2, ensure_ascii=False)
    (ROOT / "codemeta.json").write_text(text + "\n", encoding="utf-8")

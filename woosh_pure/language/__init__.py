"""The languages of the commands' texts.

Everything below says its sentences in English. This room has a table of them for each other language,
English beside the translation, with named placeholders: `zh/*.txt`. A sentence is looked up when it is
printed, and its facts are put into the translated one; who composes a sentence knows nothing of it. JSON
for programs stays as it is. The table itself (`table.translator_for`) is loaded when somebody wants another
language than English.
"""

from __future__ import annotations

from woosh_pure.language.choice import LANGUAGES, language_of

__all__ = ["LANGUAGES", "language_of"]

"""The languages of the commands' texts.

All other packages write English sentences. This package has a table for each other language, with named
placeholders: `zh/*.txt`. A sentence is looked up when it is printed, and its values are filled into the
translation. JSON for programs is not translated. The table (`table.translator_for`) is loaded only for a
language other than English.
"""

from __future__ import annotations

from woosh_pure.language.choice import LANGUAGES, language_of

__all__ = ["LANGUAGES", "language_of"]

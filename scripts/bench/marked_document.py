# SPDX-License-Identifier: BSD-2-Clause
"""Parts of documents that scripts make: what stands between a line with the part's mark and the next end mark."""

END = "<!-- end -->"


def put_between_marks(document, name, text):
    """Replaces the part of this name in the file. @return whether it has one; otherwise the file is untouched"""
    begin = f"<!-- {name} -->"
    head, found, rest = document.read_text(encoding="utf-8").partition(begin)
    _, ended, tail = rest.partition(END)
    if not found or not ended:
        return False
    document.write_text(f"{head}{begin}\n{text}\n{END}{tail}", encoding="utf-8")
    return True

"""blocks.py PAGE.md FOLDER: the code blocks of a page, each paragraph a file LANGUAGE_BLOCK_PARAGRAPH.inc in FOLDER, so that
the tests compile and run what the page shows. Files that did not change are not written again."""

import pathlib
import re
import sys

page, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
count = {}
for language, block in re.findall(r"^```(\w+)\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
    count[language] = count.get(language, 0) + 1
    for number, paragraph in enumerate(block.split("\n\n"), 1):
        file = folder / f"{language}_{count[language]}_{number}.inc"
        text = paragraph.rstrip("\n") + "\n"
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")

"""Refuse the data sheets that cannot be assessed, all of them at once."""

from pathlib import Path

from job import logged

with logged(snakemake):
    from lsvib.errors import InputError
    from lsvib.sheets.assessment import require_a_drive
    from lsvib.sheets.draw import Draw
    from lsvib.sheets.sheet import Sheet
    from lsvib.sheets.statics import statics
    from lsvib.sheets.window import OperatingWindow

    refused = []
    for file in snakemake.input:
        try:
            sheet = Sheet.read(Path(file))
            statics(sheet)
            if not sheet.of_statics:
                require_a_drive(OperatingWindow(Draw.of(sheet)))
        except InputError as error:
            refused.append(f"{file}: {error}")
    if refused:
        raise InputError(" ".join(refused))

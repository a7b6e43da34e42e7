"""``auvmission replay``: run the recorded inputs again and compare the outputs."""

from __future__ import annotations

from pathlib import Path

import click

from mission.commands.options import AS_JSON


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--rounded",
    is_flag=True,
    help="Estimates may differ in their last digits: another kind of processor recorded them.",
)
@AS_JSON
def replay(file: Path, rounded: bool, as_json: bool) -> None:
    """Re-run the black box FILE and compare every step, estimate and sent byte.

    Exit 0 if the recording is complete and identical (with --rounded: except for rounding), 1 if it
    differs (the first divergence is printed), 2 if FILE cannot be used, 3 if it is the same but
    records are missing (cut or damaged; the part that was compared is printed). FILE may be any
    part of a recording in parts.
    """
    import json

    from mission.analysis.replay.replay import ReplayError, describe, summary
    from mission.analysis.replay.replay import replay as again
    from mission.onboard.blackbox import BlackBoxError, recording

    try:
        result = again(list(recording(file)), rounded)
    except (BlackBoxError, ReplayError) as error:
        click.echo(f"{file}: {error}" if isinstance(error, ReplayError) else str(error), err=True)
        raise SystemExit(2) from None
    for gap in result.gaps:
        click.echo(str(gap), err=True)
    if as_json:
        found = result.divergence
        first = found and {
            "t": found.t,
            "record": found.number,
            "after": describe(found.cause),
            "recorded": describe(found.expected),
            "now": describe(found.actual),
        }
        data = {
            "identical": result.identical,
            "records": result.records,
            "inputs": result.inputs,
            "until_s": result.until,
            "version": result.version,
            "divergence": first,
            "rounded": result.rounded,
            "apart": result.apart,
            "missing": [
                {
                    "after_s": gap.after,
                    "before_s": gap.before,
                    "records": gap.records,
                    "bytes": gap.lost,
                }
                for gap in result.gaps
                if not gap.whole
            ],
            "not_compared": result.beyond,
        }
        click.echo(json.dumps(data))
    else:
        click.echo(summary(result))
    raise SystemExit(0 if result.whole else 3 if result.same else 1)

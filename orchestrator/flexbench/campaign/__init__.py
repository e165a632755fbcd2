"""Campaigns: thousands of runs of a system over dispersed inputs, each repeatable by its number.

Files in the folder of a campaign, once it is merged:

campaign.toml
    the campaign file as it was read, byte by byte
campaign.json
    what it resolves to: `name`, `seed`, `cases`, `runs`, `sampling`, `systems` (names), `stop_time` [s], and
    `inputs`       [{name, kind, targets, unit, distribution, discrete}]; kind: parameter, fault, delay, command, system
    `metrics`      [{name, unit, shown_unit, scale, text}]; values are in `unit` (SI), shown is value / scale
    `requirements` [{name, metric, most, least, probability, confidence}]; limits in the metric's SI unit or null
    `files`        {name: SHA-256} of systems, FMUs, fault and command files
results.parquet
    a row a run, by number. Its bytes depend on the campaign file, its files and versions alone: not on workers, engine,
    interruptions. Columns:
    `number` int64, from 1     `case` int64, from 1: systems of one case have the same draws     `system` string
    `input.NAME`  double or string, as drawn, in the unit of the campaign file (field metadata `unit`)
    `metric.NAME` double, SI (field metadata `unit`). Null: the run failed, or does not have it. +inf: a time until
                  something that did not happen, such as settling
    `status` string: completed, failed
    `failure` string: "", error (of the run), crash, hang, vanished      `cause` string: one line, "" if completed
    `simulated_time` double [s]      `rows_sha256` string: of the recorded rows
timings.parquet
    what differs between two executions: `number`, `attempts` int64, `wall_time` [s], `worker` string, `ended` [s of the
    epoch]
bands.parquet
    with `histories = "bands"`: `system` string, `signal` string, `time` double [s], `runs` int64, `least`, `pNN`...,
    `largest`
runs/N/
    results folders of the runs whose histories are kept, and of `flexsat campaign rerun`

`flexbench.campaign.result_file.read_results(folder)` reads the first three.
"""

"""deploy/campaign: the manifests fit each other and the page, and their scheduler and worker do jobs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
import yaml
from labour import do
from test_cluster import ROOT, SQUARES, begun

from mission.verification.workers import results
from mission.verification.workers.places import place

DEPLOY = ROOT / "deploy" / "campaign"
CLUSTER, POLICY = yaml.safe_load_all((DEPLOY / "cluster.yaml").read_text())


def container(of: str) -> dict[str, Any]:
    (found,) = CLUSTER["spec"][of]["spec"]["containers"]
    return dict(found)


def test_nobody_but_its_own_pods_and_the_operator_reaches_the_cluster() -> None:
    own = {"matchLabels": {"dask.org/cluster-name": CLUSTER["metadata"]["name"]}}
    assert POLICY["spec"]["podSelector"] == own
    assert POLICY["spec"]["policyTypes"] == ["Ingress"]
    ((rule),) = POLICY["spec"]["ingress"]
    pods, operator = rule["from"]
    assert pods == {"podSelector": own}
    assert [*operator] == ["namespaceSelector"]


def test_the_page_reaches_the_scheduler_by_its_service_and_one_program_is_everywhere() -> None:
    page = (ROOT / "docs" / "how-to" / "campaign.md").read_text()
    service = CLUSTER["spec"]["scheduler"]["service"]
    ((port),) = service["ports"]
    assert f"service/{CLUSTER['metadata']['name']}-scheduler 8786:{port['port']}" in page
    assert port["targetPort"] == container("scheduler")["ports"][0]["name"]
    assert service["selector"]["dask.org/cluster-name"] == CLUSTER["metadata"]["name"]
    assert container("scheduler")["image"] == container("worker")["image"]
    assert container("worker")["image"] in page


def test_the_image_has_all_that_its_wheel_is_made_of() -> None:
    copied = [line.split() for line in (DEPLOY / "Dockerfile").read_text().splitlines()]
    sources = {name for line in copied if line[:1] == ["COPY"] for name in line[1:-1]}
    assert all((ROOT / name).exists() for name in sources)
    assert {"mission", "links", "protocol", "missions", "pyproject.toml"} <= sources


@pytest.mark.proof
@pytest.mark.xdist_group("cluster")
def test_what_the_manifest_begins_does_jobs(tmp_path: Path) -> None:
    dask, scheduler, *options = container("scheduler")["args"]
    assert (dask, scheduler) == ("dask", "scheduler")
    here = ["dask_scheduler", *options, "--host", "127.0.0.1", "--port", "0"]
    with begun(here, tmp_path, str(ROOT), b"Scheduler at") as rest:
        address = rest.decode().partition("tcp://")[2].strip()
        dask, worker, *options = container("worker")["args"]
        assert (dask, worker) == ("dask", "worker")
        call = ["dask_worker", *(o.replace("$(DASK_WORKER_NAME)", "one") for o in options)]
        path = os.pathsep.join([str(ROOT), str(ROOT / "tests" / "worlds")])
        operators = {"DASK_SCHEDULER_ADDRESS": f"tcp://{address}"}
        with begun(call, tmp_path, path, b"Registered to", **operators):
            found = list(results(do, SQUARES, place(f"dask://{address}")))
    assert found == [do(square) for square in SQUARES]

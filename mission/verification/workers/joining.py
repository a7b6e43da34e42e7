"""Join a Dask cluster: connect to its scheduler, and ask its workers which program they run."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from ipaddress import ip_address

import distributed

from mission.verification.workers.code import code
from mission.verification.workers.on_worker import unfit
from mission.verification.workers.outcome import Unreachable

CONNECTING = 10.0  # s until a scheduler must have answered
JOINING = 30.0  # s until there must be a worker
ANSWERING = 60.0  # s until a worker must have told its program, which it has to import first
CLOSING = 1.0  # s that the farewell to the scheduler may take
_LOG = logging.getLogger("auvmission")


@contextmanager
def joined(address: str) -> Iterator[distributed.Client]:
    """Yield a connection to the scheduler at HOST:PORT, which has workers that can be used. Raises
    Unreachable."""
    for name in ("distributed", "distributed.client"):  # Unreachable says it all
        logging.getLogger(name).setLevel(logging.CRITICAL)
    url = url_of(address)
    client = _connected(url)
    try:
        with reached(url):
            _compare(client, url)
        yield client
    finally:
        with suppress(TimeoutError):
            client.close(timeout=CLOSING)


def url_of(address: str) -> str:
    """Return the URL of a scheduler, with TLS unless it is on this machine: whoever reaches a
    scheduler can run any code there."""
    host = address.rpartition(":")[0].strip("[]")
    return f"{'tcp' if _loopback(host) else 'tls'}://{address}"


def _loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _connected(url: str) -> distributed.Client:
    security = distributed.Security(require_encryption=url.startswith("tls"))
    if security.require_encryption and not _has_keys(security):
        raise Unreachable(f"{url} is beyond this machine, and needs keys: docs/how-to/campaign.md")
    try:
        return distributed.Client(
            url, security=security, timeout=CONNECTING, set_as_default=False, name="auvmission"
        )
    except (OSError, ValueError, RuntimeError) as error:
        raise Unreachable(f"no scheduler at {url}: {error or type(error).__name__}") from None


def _has_keys(security: distributed.Security) -> bool:
    try:
        return bool(security.get_connection_args("client")["ssl_context"])
    except (OSError, ValueError) as error:
        named = (security.tls_ca_file, security.tls_client_cert, security.tls_client_key)
        files = ", ".join(name for name in named if name and "\n" not in name)  # else it is the key
        raise Unreachable(f"the keys cannot be read ({files}): {error}") from None


def gone(url: str) -> Unreachable:
    return Unreachable(
        f"the scheduler at {url} is gone; the same command continues from what --resume has kept"
    )


@contextmanager
def reached(url: str) -> Iterator[None]:
    """For what asks the scheduler something, which is gone meanwhile."""
    try:
        yield
    except OSError:  # also a closed connection of Dask's
        raise gone(url) from None


def _compare(client: distributed.Client, url: str) -> None:
    """Ask all workers for their program. Raises Unreachable for one that has another; one that does
    not answer is left out."""
    try:
        client.wait_for_workers(1, timeout=JOINING)
    except TimeoutError:
        raise Unreachable(f"the scheduler at {url} has no worker") from None
    threads = client.nthreads()
    told = _told(client, list(threads))
    silent = [worker for worker, theirs in told.items() if isinstance(theirs, OSError)]
    if len(silent) == len(told):
        raise Unreachable(f"no worker of the scheduler at {url} answers: {', '.join(silent)}")
    found = [
        f"{worker} {why}"
        for worker, theirs in told.items()
        if worker not in silent and (why := _unfit(threads[worker], theirs))
    ]
    if found:
        raise Unreachable("workers that cannot be used: " + "; ".join(found))
    for worker in silent:
        leave_out(client, worker, "does not answer")


def _told(
    client: distributed.Client, workers: list[str]
) -> dict[str, Mapping[str, str] | Exception]:
    async def one(worker: str) -> Mapping[str, str] | Exception:
        asked = client.run(code, workers=[worker], on_error="return")
        try:
            found: dict[str, Mapping[str, str] | Exception] = await asyncio.wait_for(
                asked, ANSWERING
            )
        except TimeoutError as error:
            return error
        return found[worker]

    async def each() -> list[Mapping[str, str] | Exception]:
        return await asyncio.gather(*map(one, workers))

    return dict(zip(workers, client.sync(each), strict=True))


def _unfit(threads: int, theirs: Mapping[str, str] | Exception) -> str:
    if isinstance(theirs, Exception):
        return f"has no auvmission ({type(theirs).__name__}: {theirs})"
    return unfit(threads, theirs, code())


def leave_out(client: distributed.Client, worker: str, why: str) -> None:
    """See that the scheduler gives a worker no more jobs, and say so."""
    _LOG.warning("%s %s: it is left out", worker, why)
    client.retire_workers([worker], close_workers=False)

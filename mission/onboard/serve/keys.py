"""A small certificate authority for one vehicle and its boats, made with the `openssl` program.

    FOLDER/authority/  ca.pem ca.key     stays with the team: never at sea or on the vehicle
    FOLDER/<end>/      ca.pem cert.pem key.pem     one per end, copied to it whole

Existing folders are kept, never overwritten: a further call with another name adds an end. The
program `openssl` is used because it is on every Pi and laptop already; a Python library would be a
compiled dependency of the vehicle for something that is done once. Certificates are valid from 2020
on: after a power cut a Pi without a battery clock has an old date, and must still be reached.

    KeysError      (the operator must act)

What does not live here: the use of the keys (links.tls).
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

AUTHORITY = "authority"
VEHICLE, BOAT, VIEWER = "vehicle", "boat", "viewer"
SECONDS = 60  # timeout of openssl

_CONFIGURATION = """\
[ca]
default_ca = team
[team]
database = {work}/index
serial = {work}/serial
rand_serial = yes
new_certs_dir = {work}
default_md = sha256
policy = any
unique_subject = no
default_startdate = 20200101000000Z
default_enddate = 20500101000000Z
[any]
commonName = supplied
organizationalUnitName = optional
[req]
distinguished_name = dn
prompt = no
[dn]
CN = {name}
{unit}
[authority]
basicConstraints = critical,CA:TRUE,pathlen:0
keyUsage = critical,keyCertSign
subjectKeyIdentifier = hash
"""
_END = """\
[{role}]
basicConstraints = critical,CA:FALSE
keyUsage = critical,digitalSignature
extendedKeyUsage = {use}
subjectKeyIdentifier = hash
authorityKeyIdentifier = keyid
"""
_USES = {VEHICLE: "serverAuth", BOAT: "clientAuth", VIEWER: "clientAuth"}


class KeysError(OSError):
    pass


def make_keys(
    folder: Path, boats: Sequence[str], made: Callable[[Path], None], viewers: Sequence[str] = ()
) -> None:
    """Make the authority, the vehicle's end and one for each boat and viewer, where missing.

    ``made`` is called with each new folder. Raises KeysError.
    """
    openssl = shutil.which("openssl")
    if openssl is None:
        raise KeysError("the program openssl is not installed: apt install openssl, or make the "
                        "keys on another computer and copy the folders")  # fmt: skip
    for boat in (*boats, *viewers):
        if not boat.replace("-", "").isalnum() or boat in (AUTHORITY, VEHICLE):
            raise KeysError(f"{boat!r} is no name for a boat: letters, digits and hyphens")
    _keep_apart(openssl, folder, boats, viewers)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        authority = folder / AUTHORITY
        if not authority.exists():
            _make(openssl, authority, AUTHORITY, "authority", None)
            made(authority)
        roles = {VEHICLE: VEHICLE, **dict.fromkeys(boats, BOAT), **dict.fromkeys(viewers, VIEWER)}
        for end, role in roles.items():
            if not (folder / end).exists():
                _make(openssl, folder / end, end, role, authority)
                made(folder / end)
    except OSError as error:
        if isinstance(error, KeysError):
            raise
        raise KeysError(f"{folder}: {error.strerror or error}") from error


def _keep_apart(openssl: str, folder: Path, boats: Sequence[str], viewers: Sequence[str]) -> None:
    """Check that no name is a boat and a viewer. Raises KeysError before anything is made."""
    if both := set(boats) & set(viewers):
        raise KeysError(
            f"{min(both)!r} cannot be a boat and a viewer: give the viewer its own name"
        )
    for name, role in (*((b, BOAT) for b in boats), *((v, VIEWER) for v in viewers)):
        there = folder / name / "cert.pem"
        if there.exists() and (is_now := _role(openssl, there)) != role:
            may = "may command the vehicle" if is_now == BOAT else "may only look"
            raise KeysError(
                f"{folder / name} is there, and is a {is_now}'s, who {may}: "
                f"give the {role} another name"
            )


def _role(openssl: str, certificate: Path) -> str:
    """The role of a certificate, as ``_make`` wrote it."""
    run = [openssl, "x509", "-in", str(certificate), "-noout", "-subject", "-nameopt", "RFC2253"]
    return VIEWER if f"OU={VIEWER}" in _run(run) else BOAT


def _make(openssl: str, end: Path, name: str, role: str, authority: Path | None) -> None:
    """Make the folder of one end, completely or not at all."""
    with tempfile.TemporaryDirectory(dir=end.parent, prefix=".keys-") as temporary:
        work, out = Path(temporary), Path(temporary) / "out"
        out.mkdir(mode=0o700)
        certificate, key = ("ca.pem", "ca.key") if authority is None else ("cert.pem", "key.pem")
        configuration = work / "openssl.cnf"
        unit = f"OU = {VIEWER}" if role == VIEWER else ""
        said = _CONFIGURATION.format(work=work, name=f"auvmission {name}", unit=unit)
        ends = "".join(_END.format(role=end_role, use=use) for end_role, use in _USES.items())
        configuration.write_text(said + ends, encoding="ascii")
        (work / "index").touch()
        request = work / "request.pem"
        run = [openssl]
        _run([*run, "genpkey", "-algorithm", "EC", "-pkeyopt", "ec_paramgen_curve:P-256",
              "-out", str(out / key)])  # fmt: skip
        (out / key).chmod(0o600)
        _run([*run, "req", "-new", "-config", str(configuration), "-key", str(out / key),
              "-out", str(request)])  # fmt: skip
        signer = (
            ["-selfsign", "-keyfile", str(out / key)]
            if authority is None
            else ["-cert", str(authority / "ca.pem"), "-keyfile", str(authority / "ca.key")]
        )
        _run([*run, "ca", "-batch", "-notext", "-config", str(configuration), "-extensions", role,
              *signer, "-in", str(request), "-out", str(out / certificate)])  # fmt: skip
        if authority is not None:
            shutil.copy(authority / "ca.pem", out / "ca.pem")
        out.rename(end)


def _run(command: list[str]) -> str:
    """Run openssl; return what it printed. Raises KeysError."""
    try:
        done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.CalledProcessError as error:
        said = error.stderr.strip().splitlines() or ["without a word"]
        raise KeysError(f"openssl {command[1]} failed: {said[-1]}") from error
    except subprocess.TimeoutExpired as error:
        raise KeysError(f"openssl {command[1]} does not end") from error
    return done.stdout

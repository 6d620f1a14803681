"""A client of a running system, over its HTTP gateway."""

from __future__ import annotations

import json
import math
import urllib.parse
from typing import Any, TypeVar, overload

from asmotion.component import Interface, Operation
from asmotion.errors import CallError
from asmotion.numbers import NumberView
from asmotion.types import Form, Record, form_of

R = TypeVar("R")

_KINDS = {503: "unavailable", 504: "timeout"}


def connect(url: str, *, token: str | None = None, timeout_s: float = 10.0) -> Client:
    """Returns a client of the gateway at this address, for example `http://127.0.0.1:8080`.

    Args:
        token: the gateway's token, if it has one.
        timeout_s: deadline of calls that name none.

    Raises:
        ValueError: the address is not one of HTTP.
        CallError: there is no gateway at the address.
    """
    parts = urllib.parse.urlsplit(url)
    if parts.scheme in ("amqp", "amqps"):  # not shown: it may contain a password
        raise ValueError("this package has no client of a broker; connect to an HTTP gateway, as in `http://127.0.0.1:8080`")
    if parts.scheme not in ("http", "https") or not parts.netloc:
        raise ValueError(f"`{url}` is no address of an HTTP gateway; write it as `http://127.0.0.1:8080`")
    client = Client(url.rstrip("/"), token, timeout_s)
    client.services()
    return client


class Client:
    """A running system, seen through its gateway.

        robot = asmotion.connect("http://127.0.0.1:8080")
        grid = robot.call("maps.getMap", {"name": "office"})
        robot.maps.getMap(name="office").info.width
    """

    def __init__(self, url: str, token: str | None, timeout_s: float) -> None:
        self.url = url
        self.timeout_s = timeout_s
        self._token = token

    def services(self) -> list[Record]:
        """Returns the services, with their operations and the JSON Schema of arguments and results.

        Raises:
            CallError: the gateway does not answer.
        """
        return list(_list(self._get("/services"), "services"))

    def components(self) -> list[Record]:
        """Returns the components of the process, with state, rate and losses.

        Raises:
            CallError: the gateway does not answer.
        """
        return list(_list(self._get("/components"), "components"))

    def component(self, name: str) -> Record:
        """Returns one component: state, rate, losses and inspection.

        Raises:
            CallError: there is no such component, with the nearest name.
        """
        found: Record = self._get(f"/components/{urllib.parse.quote(name)}")
        return found

    def health(self) -> Record:
        """Returns whether calls can succeed, as `state`, and the reason if they cannot.

        Raises:
            CallError: the gateway does not answer.
        """
        status, body = self._exchange("GET", "/health", None, self.timeout_s)
        if status not in (200, 503):
            raise _problem(status, body)
        found: Record = body
        return found

    @overload
    def call(
        self, operation: str, argument: Any = None, *, timeout_s: float | None = None, returns: type[R]
    ) -> R: ...

    @overload
    def call(self, operation: str, argument: Any = None, *, timeout_s: float | None = None) -> Any: ...

    def call(
        self, operation: str, argument: Any = None, *, timeout_s: float | None = None, returns: Any = Any
    ) -> Any:
        """Calls an operation, `service.operation`, and returns its result.

        The argument is a message, or a mapping with the fields by name; omitted fields have their defaults. The result has
        the type `returns`; without it, records are `Record`.

        Raises:
            CallError: `timeout`, `unavailable`, `stopped`, or `fault` with the code of the provider.
            MismatchError: the result does not have the type `returns`.
        """
        result = self._post(operation, argument, timeout_s, "")
        return form_of(returns, "`returns`").load(result)

    def call_one_way(self, operation: str, argument: Any = None, *, timeout_s: float | None = None) -> None:
        """Calls an operation without waiting for its reply: returns when the component has the request.

        Raises:
            CallError: the component does not have it.
        """
        self._post(operation, argument, timeout_s, "&oneway=true")

    def service(self, name: str, interface: type[Interface] | None = None) -> ServiceClient:
        """Returns a service, whose operations are methods. With an interface, results have its types."""
        return ServiceClient(self, name, interface)

    def __getattr__(self, name: str) -> ServiceClient:
        if name.startswith("_"):
            raise AttributeError(name)
        return ServiceClient(self, name, None)

    def _get(self, path: str) -> Any:
        status, body = self._exchange("GET", path, None, self.timeout_s)
        if status != 200:
            raise _problem(status, body)
        return body

    def _post(self, operation: str, argument: Any, timeout_s: float | None, more: str) -> Any:
        service, dot, name = operation.rpartition(".")
        if not dot:
            raise ValueError(f"`{operation}` names no operation; write it as `service.operation`")
        allowed = self.timeout_s if timeout_s is None else timeout_s
        path = f"/services/{urllib.parse.quote(service)}/{urllib.parse.quote(name)}"
        content = json.dumps(_json({} if argument is None else Form().dump(argument)), allow_nan=False).encode()
        query = f"?timeout_ms={max(1, math.ceil(allowed * 1e3))}{more}"
        status, body = self._exchange("POST", path + query, content, allowed + 1.0)
        if status not in (200, 202):
            raise _problem(status, body)
        return body

    def _exchange(self, method: str, path: str, content: bytes | None, timeout_s: float) -> tuple[int, Any]:
        # not at the top: components, which import this module too, start faster without
        import urllib.error
        import urllib.request

        class NoRedirect(urllib.request.HTTPRedirectHandler):
            def redirect_request(self, *_: Any) -> None:
                return None

        request = urllib.request.Request(self.url + path, data=content, method=method)
        request.add_header("Accept", "application/json")
        if content is not None:
            request.add_header("Content-Type", "application/json")
        if self._token is not None:
            request.add_header("Authorization", f"Bearer {self._token}")
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}), NoRedirect())
        try:
            with opener.open(request, timeout=timeout_s) as response:
                return response.status, _body(response.read())
        except urllib.error.HTTPError as error:
            with error:
                return error.code, _body(error.read())
        except TimeoutError:
            raise CallError("timeout") from None
        except (urllib.error.URLError, ConnectionError) as error:
            reason = getattr(error, "reason", error)
            if isinstance(reason, TimeoutError):
                raise CallError("timeout") from None
            raise CallError("unavailable", text=f"{self.url} does not answer: {reason}") from None


class ServiceClient:
    """A service of a running system: `service.operation(field=value)` or `service.operation(message)`."""

    def __init__(self, client: Client, name: str, interface: type[Interface] | None) -> None:
        self._client = client
        self._name = name
        self._operations: dict[str, Operation[Any, Any]] | None = None if interface is None else interface.declared()

    def __getattr__(self, operation: str) -> Any:
        if operation.startswith("_"):
            raise AttributeError(operation)
        returns: Any = Any
        if self._operations is not None:
            if operation not in self._operations:
                known = ", ".join(self._operations)
                raise AttributeError(f"`{self._name}` has no operation `{operation}`; it has {known}")
            returns = self._operations[operation].response

        def call(argument: Any = None, *, timeout_s: float | None = None, **fields: Any) -> Any:
            if argument is not None and fields:
                raise TypeError(f"`{self._name}.{operation}` has either a message or fields as its argument")
            address = f"{self._name}.{operation}"
            return self._client.call(address, fields if argument is None else argument, timeout_s=timeout_s, returns=returns)

        return call


def _body(content: bytes) -> Any:
    if not content:
        return None
    try:
        return Form().load(json.loads(content))
    except ValueError:
        return Record(detail=content[:200].decode(errors="replace"))


def _list(body: Any, key: str) -> Any:
    return body[key] if isinstance(body, dict) and key in body else body


def _problem(status: int, body: Any) -> CallError:
    """Returns the error of problem details (RFC 9457)."""
    body = body if isinstance(body, dict) else {}
    code = body.get("code", f"HTTP_{status}")
    kind = "stopped" if code == "STOPPED" else _KINDS.get(status, "fault")
    text = body.get("detail") or body.get("title") or f"HTTP status {status}"
    if body.get("help"):
        text = f"{text} ({body['help']})"
    return CallError(kind, code, text)


def _json(value: Any) -> Any:
    """Returns data with the texts that JSON has for lists of numbers and for floats that are no number."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, dict):
        return {key: _json(element) for key, element in value.items()}
    if isinstance(value, NumberView):
        return [_json(element) for element in value.tolist()]
    if isinstance(value, (list, tuple)):
        return [_json(element) for element in value]
    if hasattr(value, "tolist"):
        return _json(value.tolist())
    return value

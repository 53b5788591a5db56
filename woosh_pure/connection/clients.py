"""Publishers, service clients and action clients of one chassis.

Each is made on first use and kept until close. Safe from any thread.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import rosproto
from rosproto.codec import DynamicMessage, Message, ValuesLost
from rosproto.errors import RosTimeout
from rosproto.node import Cancellation, PreparedCall
from rosproto.sentence import say
from rosproto.transport import Deadline
from woosh_pure.connection.call_scope import current
from woosh_pure.connection.connection import Connection
from woosh_pure.connection.firmware_limits import limit_error, require_message
from woosh_pure.enums import TaskCommand
from woosh_pure.firmware.survey import survey
from woosh_pure.interface import row
from woosh_pure.values.messages import message_type, service_type


class Clients:
    """Publishers, service clients and action clients of one chassis.

    Args:
        connection: Its node makes and closes them.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._publishers: dict[str, rosproto.Publisher] = {}
        self._services: dict[str, rosproto.ServiceClient] = {}
        self._actions: dict[str, rosproto.ActionClient] = {}

    def publisher(self, topic: str, type_: type[Message] | str) -> rosproto.Publisher:
        """Return a publisher of any topic and type, kept until close.

        A type name means the bundled definition; a user's own type of that name is passed as a class.
        """
        type_ = message_type(type_) if isinstance(type_, str) else type_
        self._connection.require_open()
        with self._connection.making:
            if topic not in self._publishers:
                self._publishers[topic] = self._connection.open_node().publisher(topic, type_, queue_size=10)
            return self._publishers[topic]

    def wait_any(self, publishers: Sequence[rosproto.Publisher], timeout: float) -> None:
        """Wait until one of several publishers has a subscriber.

        Raises:
            RosTimeout: None has one in time.
        """
        deadline = Deadline(timeout)
        while not any(p.connections for p in publishers):
            if deadline.expired:
                names = " or ".join(p.topic for p in publishers)
                raise RosTimeout(
                    say("{name} has no subscriber; this chassis may not have it", name=names),
                    what=names,
                    seconds=timeout,
                )
            time.sleep(0.01)

    def connect(self, topic: str, type_: type[Message] | str) -> None:
        """Wait until the chassis subscribes to a topic, without sending anything.

        Raises:
            RosTimeout: No node of the chassis subscribes.
        """
        self.publisher(topic, type_).wait_for_connection(timeout=self._connection.timeout)

    def send(self, topic: str, message: Message, timeout: float | None = None) -> None:
        """Publish once, after the chassis has connected.

        Raises:
            RosTimeout: No node of the chassis subscribes.
        """
        publisher = self.publisher(topic, type(message))
        publisher.wait_for_connection(timeout=self._connection.timeout if timeout is None else timeout)
        self.deliver(publisher, message)

    def deliver(self, publisher: rosproto.Publisher, message: Message) -> None:
        """Publish once, with a publisher that the chassis has connected to.

        Raises:
            FirmwareLimit: The chassis's definition has no field for a value given; nothing was sent.
            MotionRefused: The call was cancelled.
        """
        require_message(publisher.topic, publisher, message)
        if (scope := current()) is not None:
            scope.require_wanted(publisher.topic)
        publisher.publish(message)
        publisher.flush(self._connection.timeout)

    def service(self, name: str) -> rosproto.ServiceClient:
        """The client of a service of the interface."""
        self._connection.require_open()
        if made := self._services.get(name):
            return made  # no lock: a cancel must not wait for a verb that is connecting
        with self._connection.making:
            if name not in self._services:
                client = self._connection.open_node().service_client(name, service_type(row(name).type))
                client.lossless = True
                self._services[name] = client
            return self._services[name]

    def call(self, name: str, *, timeout: float | None = None, **fields: Any) -> DynamicMessage:
        """Call a service of the interface and return its response.

        Raises:
            FirmwareLimit: The chassis's definition has no field for a value given; nothing was sent.
        """
        client, seconds = self.service(name), self._connection.timeout if timeout is None else timeout
        # The cancel of a task is sent even if the call was cancelled.
        scope = None if name == "/exec_task" else current()
        try:
            reply: DynamicMessage = (
                client.call(timeout=seconds, **fields)
                if scope is None
                else client.call_cancellable(scope.calling, None, seconds, **fields)
            )
        except ValuesLost as error:
            lack = say("no field for {fields}", fields=error.fields)
            raise limit_error(name, error.theirs, error.fields, lack) from error
        return reply

    def services_of_type(self, type_name: str) -> list[str]:
        """Return the names of the services of a type, from connection headers; none is called.

        Raises:
            ConnectionLost, RosTimeout, MasterError: The master did not answer.
        """
        answers = survey(self._connection.open_node(), timeout=self._connection.timeout, kinds=("service",))
        return [answer.name for answer in answers if answer.type == type_name]

    def call_found(
        self, name: str, type_name: str, *, timeout: float | None = None, **fields: Any
    ) -> DynamicMessage:
        """Call a service whose name is not in the interface table."""
        with self._connection.open_node().service_client(name, service_type(type_name)) as client:
            cancellation = Cancellation() if (scope := current()) is None else scope.calling
            seconds = self._connection.timeout if timeout is None else timeout
            reply: DynamicMessage = client.call_cancellable(cancellation, None, seconds, **fields)
        return reply

    def action(self, name: str) -> rosproto.ActionClient:
        """The client of an action of the interface, ready to send.

        Raises:
            RosTimeout: There is no server; the text says which part is missing.
        """
        self._connection.require_open()
        with self._connection.making:
            client = self._actions.get(name)
            if client is None:
                client = rosproto.ActionClient(
                    self._connection.open_node(), name, message_type(f"{row(name).type}Action")
                )
                self._actions[name] = client
        client.wait_for_server(self._connection.timeout)
        return client

    def prepared_exec_task(self, command: TaskCommand, task_id: int) -> PreparedCall:
        """Prepare a call of /exec_task on a connection of its own; the caller closes it."""
        client, seconds = self.service("/exec_task"), self._connection.timeout
        return client.prepare(timeout=seconds, task_exect=int(command), task_id=task_id)

    def exec_task(
        self, command: TaskCommand, task_id: int, *, timeout: float, **fields: Any
    ) -> DynamicMessage:
        """Call /exec_task."""
        return self.call("/exec_task", timeout=timeout, task_exect=int(command), task_id=task_id, **fields)

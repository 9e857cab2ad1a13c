"""A bus between the threads of one process: python-can's `virtual` interface. A shell: it decides nothing."""

import can

from vehicle_gateway.can.frame import Frame


class Virtual:
    """Raises OSError where python-can raises its own errors."""

    def __init__(self, channel: str) -> None:
        self._bus = can.Bus(interface="virtual", channel=channel)

    def receive(self, timeout_s: float) -> Frame | None:
        try:
            message = self._bus.recv(timeout_s)
        except can.CanError as error:
            raise OSError(error.error_code or 0, str(error)) from None
        if message is None or message.is_error_frame:
            return None
        if message.is_extended_id or message.is_remote_frame or message.is_fd:
            raise ValueError("not a classic data frame")
        return Frame(message.arbitration_id, bytes(message.data))

    def send(self, frame: Frame) -> None:
        message = can.Message(arbitration_id=frame.arbitration_id, data=frame.data, is_extended_id=False)
        try:
            self._bus.send(message, timeout=0)
        except can.CanError as error:
            raise OSError(error.error_code or 0, str(error)) from None

    def close(self) -> None:
        self._bus.shutdown()

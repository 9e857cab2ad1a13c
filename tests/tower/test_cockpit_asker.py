import threading

from tower.cockpit.asker import Asker
from wire.clock import Clock
from wire.messages.base import Message
from wire.messages.session import LeaseReply, LeaseRequest

REQUEST = LeaseRequest(operator="o", session="s", sent_ns=1)
REPLY = LeaseReply(granted=False, epoch=0, key_hex="", rule="no", boot_id="b")


def test_one_question_at_a_time_without_waiting_for_its_answer() -> None:
    may_answer, answered = threading.Event(), threading.Event()

    def ask(query: str, request: Message, timeout_s: float) -> Message | None:
        may_answer.wait(5.0)
        answered.set()
        return REPLY if timeout_s == 0.5 and query == "lease" else None

    with Asker(ask, Clock()) as asker:
        assert asker.offer("lease", REQUEST)
        assert not asker.offer("lease", REQUEST)
        assert asker.answers.drain() == []
        may_answer.set()
        assert answered.wait(5.0)
    assert not asker.busy
    assert [received.message.reply for received in asker.answers.drain()] == [REPLY]

"""The table of this process's topics."""

import threading

from rosproto.errors import MasterError, RosError
from rosproto.names import is_usable_name

from . import core
from ._topics import PublisherImpl, SubscriberImpl
from .exceptions import ROSException
from .impl.registration import Registration, get_registration_listeners


class TopicManager:
    """The topics of this process."""

    def __init__(self):
        self.pubs = {}
        self.subs = {}
        self.lock = threading.RLock()
        self._node = None

    def attach(self, node):
        """Use the node, and open the topics made before it existed."""
        with self.lock:
            self._node = node
            for impl in [*self.pubs.values(), *self.subs.values()]:
                self._open(impl)

    def _table(self, reg_type):
        return self.pubs if reg_type == Registration.PUB else self.subs

    def acquire_impl(self, reg_type, resolved_name, data_class, options):
        """The implementation of a topic, created with the first use; `options(impl)` sets it up."""
        with self.lock:
            table = self._table(reg_type)
            impl = table.get(resolved_name)
            if impl is None:
                kind = PublisherImpl if reg_type == Registration.PUB else SubscriberImpl
                impl = kind(resolved_name, data_class)
                options(impl)
                if self._node is not None:
                    self._open(impl)
                table[resolved_name] = impl
                get_registration_listeners().notify_added(resolved_name, impl.type, reg_type)
            else:
                options(impl)
            impl.ref_count += 1
            return impl

    def _open(self, impl):
        try:
            if is_usable_name(impl.resolved_name):
                impl.attach(self._node)
            else:
                self._refuse(impl, "ERROR: parameter [topic] contains illegal chars")
        except MasterError as error:
            self._refuse(impl, error.text)
        except (RosError, OSError) as error:
            if not core.is_shutdown():
                raise ROSException("cannot register [%s]: %s" % (impl.resolved_name, error)) from error

    @staticmethod
    def _refuse(impl, text):
        """Mark a topic as refused; the program continues without it, as in rospy."""
        impl.refused = True
        core.logfatal("unable to register %s [%s] with master: %s" % (impl.KIND, impl.resolved_name, text))

    def release_impl(self, reg_type, resolved_name):
        """Release a topic; the last release closes it."""
        with self.lock:
            table = self._table(reg_type)
            impl = table.get(resolved_name)
            if impl is None:
                return
            impl.ref_count -= 1
            if impl.ref_count:
                return
            del table[resolved_name]
        impl.close()
        get_registration_listeners().notify_removed(resolved_name, impl.type, reg_type)

    def get_impl(self, reg_type, resolved_name):
        """The implementation of a topic, None when there is none."""
        return self._table(reg_type).get(resolved_name)

    def has_subscription(self, resolved_name):
        """True when it is subscribed here."""
        return resolved_name in self.subs

    def has_publication(self, resolved_name):
        """True when it is published here."""
        return resolved_name in self.pubs

    def get_topics(self):
        """Names of all topics."""
        return {*self.pubs, *self.subs}

    def get_publications(self):
        """[[topic, type], ...]."""
        return [[name, impl.type] for name, impl in list(self.pubs.items())]

    def get_subscriptions(self):
        """[[topic, type], ...]."""
        return [[name, impl.type] for name, impl in list(self.subs.items())]


manager = TopicManager()

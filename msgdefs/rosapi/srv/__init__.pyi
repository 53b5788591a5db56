# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of rosapi as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

import msgdefs.rosapi.msg as _rosapi
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType
from rosproto.time import Time as _Time

class DeleteParamRequest(_Message):
    """rosapi/DeleteParamRequest

    string name
    """

    name: str
    def __init__(
        self,
        name: str = ...,
    ) -> None: ...

class DeleteParamResponse(_Message):
    """rosapi/DeleteParamResponse
    """

    def __init__(self) -> None: ...

class DeleteParam(_ServiceType):
    """rosapi/DeleteParam
    """

    Request: _TypeAlias = DeleteParamRequest
    Response: _TypeAlias = DeleteParamResponse

class GetActionServersRequest(_Message):
    """rosapi/GetActionServersRequest
    """

    def __init__(self) -> None: ...

class GetActionServersResponse(_Message):
    """rosapi/GetActionServersResponse

    string[] action_servers
    """

    action_servers: list[str]
    def __init__(
        self,
        action_servers: _Sequence[str] = ...,
    ) -> None: ...

class GetActionServers(_ServiceType):
    """rosapi/GetActionServers
    """

    Request: _TypeAlias = GetActionServersRequest
    Response: _TypeAlias = GetActionServersResponse

class GetParamRequest(_Message):
    """rosapi/GetParamRequest

    string name
    string default
    """

    name: str
    default: str
    def __init__(
        self,
        name: str = ...,
        default: str = ...,
    ) -> None: ...

class GetParamResponse(_Message):
    """rosapi/GetParamResponse

    string value
    """

    value: str
    def __init__(
        self,
        value: str = ...,
    ) -> None: ...

class GetParam(_ServiceType):
    """rosapi/GetParam
    """

    Request: _TypeAlias = GetParamRequest
    Response: _TypeAlias = GetParamResponse

class GetParamNamesRequest(_Message):
    """rosapi/GetParamNamesRequest
    """

    def __init__(self) -> None: ...

class GetParamNamesResponse(_Message):
    """rosapi/GetParamNamesResponse

    string[] names
    """

    names: list[str]
    def __init__(
        self,
        names: _Sequence[str] = ...,
    ) -> None: ...

class GetParamNames(_ServiceType):
    """rosapi/GetParamNames
    """

    Request: _TypeAlias = GetParamNamesRequest
    Response: _TypeAlias = GetParamNamesResponse

class GetTimeRequest(_Message):
    """rosapi/GetTimeRequest
    """

    def __init__(self) -> None: ...

class GetTimeResponse(_Message):
    """rosapi/GetTimeResponse

    time time
    """

    time: _Time
    def __init__(
        self,
        time: _Time = ...,
    ) -> None: ...

class GetTime(_ServiceType):
    """rosapi/GetTime
    """

    Request: _TypeAlias = GetTimeRequest
    Response: _TypeAlias = GetTimeResponse

class HasParamRequest(_Message):
    """rosapi/HasParamRequest

    string name
    """

    name: str
    def __init__(
        self,
        name: str = ...,
    ) -> None: ...

class HasParamResponse(_Message):
    """rosapi/HasParamResponse

    bool exists
    """

    exists: bool
    def __init__(
        self,
        exists: bool = ...,
    ) -> None: ...

class HasParam(_ServiceType):
    """rosapi/HasParam
    """

    Request: _TypeAlias = HasParamRequest
    Response: _TypeAlias = HasParamResponse

class MessageDetailsRequest(_Message):
    """rosapi/MessageDetailsRequest

    string type
    """

    type: str
    def __init__(
        self,
        type: str = ...,
    ) -> None: ...

class MessageDetailsResponse(_Message):
    """rosapi/MessageDetailsResponse

    TypeDef[] typedefs
    """

    typedefs: list[_rosapi.TypeDef]
    def __init__(
        self,
        typedefs: _Sequence[_rosapi.TypeDef] = ...,
    ) -> None: ...

class MessageDetails(_ServiceType):
    """rosapi/MessageDetails
    """

    Request: _TypeAlias = MessageDetailsRequest
    Response: _TypeAlias = MessageDetailsResponse

class NodeDetailsRequest(_Message):
    """rosapi/NodeDetailsRequest

    string node
    """

    node: str
    def __init__(
        self,
        node: str = ...,
    ) -> None: ...

class NodeDetailsResponse(_Message):
    """rosapi/NodeDetailsResponse

    string[] subscribing
    string[] publishing
    string[] services
    """

    subscribing: list[str]
    publishing: list[str]
    services: list[str]
    def __init__(
        self,
        subscribing: _Sequence[str] = ...,
        publishing: _Sequence[str] = ...,
        services: _Sequence[str] = ...,
    ) -> None: ...

class NodeDetails(_ServiceType):
    """rosapi/NodeDetails
    """

    Request: _TypeAlias = NodeDetailsRequest
    Response: _TypeAlias = NodeDetailsResponse

class NodesRequest(_Message):
    """rosapi/NodesRequest
    """

    def __init__(self) -> None: ...

class NodesResponse(_Message):
    """rosapi/NodesResponse

    string[] nodes
    """

    nodes: list[str]
    def __init__(
        self,
        nodes: _Sequence[str] = ...,
    ) -> None: ...

class Nodes(_ServiceType):
    """rosapi/Nodes
    """

    Request: _TypeAlias = NodesRequest
    Response: _TypeAlias = NodesResponse

class PublishersRequest(_Message):
    """rosapi/PublishersRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class PublishersResponse(_Message):
    """rosapi/PublishersResponse

    string[] publishers
    """

    publishers: list[str]
    def __init__(
        self,
        publishers: _Sequence[str] = ...,
    ) -> None: ...

class Publishers(_ServiceType):
    """rosapi/Publishers
    """

    Request: _TypeAlias = PublishersRequest
    Response: _TypeAlias = PublishersResponse

class SearchParamRequest(_Message):
    """rosapi/SearchParamRequest

    string name
    """

    name: str
    def __init__(
        self,
        name: str = ...,
    ) -> None: ...

class SearchParamResponse(_Message):
    """rosapi/SearchParamResponse

    string global_name
    """

    global_name: str
    def __init__(
        self,
        global_name: str = ...,
    ) -> None: ...

class SearchParam(_ServiceType):
    """rosapi/SearchParam
    """

    Request: _TypeAlias = SearchParamRequest
    Response: _TypeAlias = SearchParamResponse

class ServiceHostRequest(_Message):
    """rosapi/ServiceHostRequest

    string service
    """

    service: str
    def __init__(
        self,
        service: str = ...,
    ) -> None: ...

class ServiceHostResponse(_Message):
    """rosapi/ServiceHostResponse

    string host
    """

    host: str
    def __init__(
        self,
        host: str = ...,
    ) -> None: ...

class ServiceHost(_ServiceType):
    """rosapi/ServiceHost
    """

    Request: _TypeAlias = ServiceHostRequest
    Response: _TypeAlias = ServiceHostResponse

class ServiceNodeRequest(_Message):
    """rosapi/ServiceNodeRequest

    string service
    """

    service: str
    def __init__(
        self,
        service: str = ...,
    ) -> None: ...

class ServiceNodeResponse(_Message):
    """rosapi/ServiceNodeResponse

    string node
    """

    node: str
    def __init__(
        self,
        node: str = ...,
    ) -> None: ...

class ServiceNode(_ServiceType):
    """rosapi/ServiceNode
    """

    Request: _TypeAlias = ServiceNodeRequest
    Response: _TypeAlias = ServiceNodeResponse

class ServiceProvidersRequest(_Message):
    """rosapi/ServiceProvidersRequest

    string service
    """

    service: str
    def __init__(
        self,
        service: str = ...,
    ) -> None: ...

class ServiceProvidersResponse(_Message):
    """rosapi/ServiceProvidersResponse

    string[] providers
    """

    providers: list[str]
    def __init__(
        self,
        providers: _Sequence[str] = ...,
    ) -> None: ...

class ServiceProviders(_ServiceType):
    """rosapi/ServiceProviders
    """

    Request: _TypeAlias = ServiceProvidersRequest
    Response: _TypeAlias = ServiceProvidersResponse

class ServiceRequestDetailsRequest(_Message):
    """rosapi/ServiceRequestDetailsRequest

    string type
    """

    type: str
    def __init__(
        self,
        type: str = ...,
    ) -> None: ...

class ServiceRequestDetailsResponse(_Message):
    """rosapi/ServiceRequestDetailsResponse

    TypeDef[] typedefs
    """

    typedefs: list[_rosapi.TypeDef]
    def __init__(
        self,
        typedefs: _Sequence[_rosapi.TypeDef] = ...,
    ) -> None: ...

class ServiceRequestDetails(_ServiceType):
    """rosapi/ServiceRequestDetails
    """

    Request: _TypeAlias = ServiceRequestDetailsRequest
    Response: _TypeAlias = ServiceRequestDetailsResponse

class ServiceResponseDetailsRequest(_Message):
    """rosapi/ServiceResponseDetailsRequest

    string type
    """

    type: str
    def __init__(
        self,
        type: str = ...,
    ) -> None: ...

class ServiceResponseDetailsResponse(_Message):
    """rosapi/ServiceResponseDetailsResponse

    TypeDef[] typedefs
    """

    typedefs: list[_rosapi.TypeDef]
    def __init__(
        self,
        typedefs: _Sequence[_rosapi.TypeDef] = ...,
    ) -> None: ...

class ServiceResponseDetails(_ServiceType):
    """rosapi/ServiceResponseDetails
    """

    Request: _TypeAlias = ServiceResponseDetailsRequest
    Response: _TypeAlias = ServiceResponseDetailsResponse

class ServiceTypeRequest(_Message):
    """rosapi/ServiceTypeRequest

    string service
    """

    service: str
    def __init__(
        self,
        service: str = ...,
    ) -> None: ...

class ServiceTypeResponse(_Message):
    """rosapi/ServiceTypeResponse

    string type
    """

    type: str
    def __init__(
        self,
        type: str = ...,
    ) -> None: ...

class ServiceType(_ServiceType):
    """rosapi/ServiceType
    """

    Request: _TypeAlias = ServiceTypeRequest
    Response: _TypeAlias = ServiceTypeResponse

class ServicesRequest(_Message):
    """rosapi/ServicesRequest
    """

    def __init__(self) -> None: ...

class ServicesResponse(_Message):
    """rosapi/ServicesResponse

    string[] services
    """

    services: list[str]
    def __init__(
        self,
        services: _Sequence[str] = ...,
    ) -> None: ...

class Services(_ServiceType):
    """rosapi/Services
    """

    Request: _TypeAlias = ServicesRequest
    Response: _TypeAlias = ServicesResponse

class ServicesForTypeRequest(_Message):
    """rosapi/ServicesForTypeRequest

    string type
    """

    type: str
    def __init__(
        self,
        type: str = ...,
    ) -> None: ...

class ServicesForTypeResponse(_Message):
    """rosapi/ServicesForTypeResponse

    string[] services
    """

    services: list[str]
    def __init__(
        self,
        services: _Sequence[str] = ...,
    ) -> None: ...

class ServicesForType(_ServiceType):
    """rosapi/ServicesForType
    """

    Request: _TypeAlias = ServicesForTypeRequest
    Response: _TypeAlias = ServicesForTypeResponse

class SetParamRequest(_Message):
    """rosapi/SetParamRequest

    string name
    string value
    """

    name: str
    value: str
    def __init__(
        self,
        name: str = ...,
        value: str = ...,
    ) -> None: ...

class SetParamResponse(_Message):
    """rosapi/SetParamResponse
    """

    def __init__(self) -> None: ...

class SetParam(_ServiceType):
    """rosapi/SetParam
    """

    Request: _TypeAlias = SetParamRequest
    Response: _TypeAlias = SetParamResponse

class SubscribersRequest(_Message):
    """rosapi/SubscribersRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class SubscribersResponse(_Message):
    """rosapi/SubscribersResponse

    string[] subscribers
    """

    subscribers: list[str]
    def __init__(
        self,
        subscribers: _Sequence[str] = ...,
    ) -> None: ...

class Subscribers(_ServiceType):
    """rosapi/Subscribers
    """

    Request: _TypeAlias = SubscribersRequest
    Response: _TypeAlias = SubscribersResponse

class TopicTypeRequest(_Message):
    """rosapi/TopicTypeRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class TopicTypeResponse(_Message):
    """rosapi/TopicTypeResponse

    string type
    """

    type: str
    def __init__(
        self,
        type: str = ...,
    ) -> None: ...

class TopicType(_ServiceType):
    """rosapi/TopicType
    """

    Request: _TypeAlias = TopicTypeRequest
    Response: _TypeAlias = TopicTypeResponse

class TopicsRequest(_Message):
    """rosapi/TopicsRequest
    """

    def __init__(self) -> None: ...

class TopicsResponse(_Message):
    """rosapi/TopicsResponse

    string[] topics
    string[] types
    """

    topics: list[str]
    types: list[str]
    def __init__(
        self,
        topics: _Sequence[str] = ...,
        types: _Sequence[str] = ...,
    ) -> None: ...

class Topics(_ServiceType):
    """rosapi/Topics
    """

    Request: _TypeAlias = TopicsRequest
    Response: _TypeAlias = TopicsResponse

class TopicsAndRawTypesRequest(_Message):
    """rosapi/TopicsAndRawTypesRequest
    """

    def __init__(self) -> None: ...

class TopicsAndRawTypesResponse(_Message):
    """rosapi/TopicsAndRawTypesResponse

    string[] topics
    string[] types
    string[] typedefs_full_text
    """

    topics: list[str]
    types: list[str]
    typedefs_full_text: list[str]
    def __init__(
        self,
        topics: _Sequence[str] = ...,
        types: _Sequence[str] = ...,
        typedefs_full_text: _Sequence[str] = ...,
    ) -> None: ...

class TopicsAndRawTypes(_ServiceType):
    """rosapi/TopicsAndRawTypes
    """

    Request: _TypeAlias = TopicsAndRawTypesRequest
    Response: _TypeAlias = TopicsAndRawTypesResponse

class TopicsForTypeRequest(_Message):
    """rosapi/TopicsForTypeRequest

    string type
    """

    type: str
    def __init__(
        self,
        type: str = ...,
    ) -> None: ...

class TopicsForTypeResponse(_Message):
    """rosapi/TopicsForTypeResponse

    string[] topics
    """

    topics: list[str]
    def __init__(
        self,
        topics: _Sequence[str] = ...,
    ) -> None: ...

class TopicsForType(_ServiceType):
    """rosapi/TopicsForType
    """

    Request: _TypeAlias = TopicsForTypeRequest
    Response: _TypeAlias = TopicsForTypeResponse

"""Bodies that schemathesis does not know how to send."""

import schemathesis


@schemathesis.serializer("application/sdp")
def session_description(ctx, value):
    return value if isinstance(value, bytes) else str(value).encode()

"""Who may ask what of the service: keys, tokens, scopes, limits and the headers of every answer.

gate.py             before everything: host, caller, limits; headers on every answer
authentication.py   a request's caller: by an API key, a token, or nobody's but this computer's
keys.py, tokens.py  the two kinds of credentials
scopes.py           which route needs which scope; the route itself checks it, see strict_route.py
"""

"""What crosses the boundary between page and server, as models; OpenAPI is made from them."""

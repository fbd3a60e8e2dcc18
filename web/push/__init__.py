"""What the server tells browsers by itself, over Socket.IO."""

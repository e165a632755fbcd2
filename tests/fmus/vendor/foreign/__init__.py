"""Our controller in foreign conventions; its folder stands in the package `flexsat` while it is built."""

"""From a robot and a task to one certified gait."""

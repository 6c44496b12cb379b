"""What a selection means, in numbers and sentences: findings, the better muscle, the next experiment."""
